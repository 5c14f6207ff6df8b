"""Meshes and functions on meshes. Modules here import no modules beside this folder except the base.

In order of dependence: ``arrays``, ``mesh``, ``packages``, ``files``, and the modules of the functions.
"""
