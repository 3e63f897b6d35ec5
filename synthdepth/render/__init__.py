"""World to pictures and ground truth: the only place that knows Mitsuba."""
