"""Trees, shrubs, hedges, grass."""
