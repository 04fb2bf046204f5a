"""Formulas of mechanics as plain functions, batched over poses."""
