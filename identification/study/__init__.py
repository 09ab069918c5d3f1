"""Studies of the papers' kind: methods compared on joints by many trials."""
