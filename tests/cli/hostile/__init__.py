"""Inputs that mean harm, or that slipped: over 3,000, by combination and by hand.

Each must end in lines that say what is wrong, one a problem; `test_hostile` says how.
"""
