"""Streets: where they run, their surface, markings and what stands along them."""
