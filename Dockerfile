# docker build -t impactfem:local .
# docker run --rm -v "$PWD":/work -v ~/.cache:/cache --user "$(id -u):$(id -g)" impactfem:local run towers.toml
FROM debian:12-slim
RUN apt-get update -qq && apt-get install -qq -y --no-install-recommends ca-certificates && rm -rf /var/lib/apt/lists/*
COPY . /opt/impactfem
WORKDIR /opt/impactfem
RUN scripts/bootstrap && rm -rf /var/lib/apt/lists/* /root/.cache
ENV PATH=/opt/impactfem/.venv/bin:$PATH XDG_CACHE_HOME=/cache
WORKDIR /work
ENTRYPOINT ["impactfem"]
CMD ["--help"]
