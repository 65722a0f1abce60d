"""Figures and animations: they draw plain data and single swarms."""
