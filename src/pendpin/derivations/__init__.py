"""Equations of motion derived by hand, one route a module; none of them imports Pinocchio or another route."""
