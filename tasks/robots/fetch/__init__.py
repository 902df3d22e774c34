"""Tasks of a Fetch arm over its table (paper, appendix H)."""
