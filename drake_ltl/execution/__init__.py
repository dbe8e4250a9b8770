"""Runs missions and records them. `recording` alone needs no Drake."""
