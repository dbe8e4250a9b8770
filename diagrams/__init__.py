"""Assembly of drake_ltl's systems into Drake diagrams."""
