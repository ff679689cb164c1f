"""What figures and tables share: style, tables, spectra as products, fields over floors, scenes."""
