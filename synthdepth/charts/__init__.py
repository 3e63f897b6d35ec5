"""Charts and pages: axes, inline SVG, tables and pictures of pages that are whole in themselves."""
