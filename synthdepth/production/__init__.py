"""Plan, jobs and worker processes of a production run."""
