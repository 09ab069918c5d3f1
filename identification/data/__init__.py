"""The measurements: files, columns, curves, their parts, and motions to measure."""
