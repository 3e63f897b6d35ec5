"""Looking at a dataset: a page of it for the browser, and a recording of it for Rerun."""
