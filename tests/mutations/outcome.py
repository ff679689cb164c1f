"""What a damaged input may end in: it is good after all, or refused in words."""

import warnings

from impactfem.system.errors import InputError

LONGEST = 700  # letters of a line that a person reads


def outcome(action, folder, kind):
    """Run an action on a damaged input.

    Args:
        action: What is run.
        folder: Holds the input; its files must be the same afterwards, and refusals name it.
        kind: The error of a refusal.

    Returns:
        "good" or "refused".

    Raises:
        AssertionError: It ended in anything else.
    """
    before = sorted(folder.rglob("*"))
    found = "good"
    try:
        with warnings.catch_warnings():
            warnings.simplefilter("error")
            warnings.filterwarnings("ignore", "`product` is deprecated", DeprecationWarning)
            action()
    except kind as error:
        found = "refused"
        lines = [str(f) for f in error.faults] if isinstance(error, InputError) else [str(error)]
        assert lines and any(str(folder) in line for line in lines), lines
        assert all(len(line) < LONGEST and "\n" not in line for line in lines), lines
        assert not any("Traceback" in line for line in lines), lines
    except Exception as error:
        raise AssertionError(f"a raw {type(error).__name__}: {error}") from error
    assert sorted(folder.rglob("*")) == before, "something was written"
    return found
