"""Robots and objects shipped with drake_ltl, as the Drake package `drake_ltl_models`."""
