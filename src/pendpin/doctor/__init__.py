"""The equation doctor: printed equations of one rod checked against the true mechanics, and mended.

reading/ turns text into trees; mechanics says what each quantity truly is, in floats, 50 digits and symbols; checking
compares; needs and mending find the smallest change that heals; harm, report and page show it.
May import: dynamics, equations and what is below them; no other tool.
"""
