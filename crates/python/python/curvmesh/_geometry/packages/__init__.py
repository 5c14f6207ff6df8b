"""Conversion from and to meshes of other packages, one module for each package.

A foreign mesh is recognised by its attributes, so that no package needs to be imported.
"""
