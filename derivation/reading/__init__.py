"""Equations for people: energies and Lagrange's equations written out, a glossary of symbols, LaTeX."""
