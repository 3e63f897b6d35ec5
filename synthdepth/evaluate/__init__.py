"""How good predicted depth is: metrics, protocols, breakdowns and baselines."""
