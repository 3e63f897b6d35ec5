"""Sports grounds: pitches and courts, stands, masts, nets, and how they share a site."""
