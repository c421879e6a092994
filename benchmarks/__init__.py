"""The documentation's tables, made afresh beside floors and peers; `stillarm benchmark NAME` runs them."""
