"""Meshes of other packages in and out, one module for each package.

A foreign mesh is recognised by its attributes, so that nothing is imported to look.
"""
