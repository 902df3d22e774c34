"""Records of runs → the pages and figures of `docs/results/`, and a part of the project's README.

`python -m tiloilc.report.results` writes them (`make results`). Nothing but the records and the
task files goes in, so that the same records give the same bytes. The order of things:
`rows` (records → rows), `book` (which row a page means), `measures`, `drawing`, `pages`, `write`.
"""
