"""Public measurements: the catalogue of them, and how they get here."""
