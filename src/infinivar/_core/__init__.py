"""Array namespaces, complex step, physical fields, frozen containers and text files: no physics."""
