"""Houses, from massing to gutters."""
