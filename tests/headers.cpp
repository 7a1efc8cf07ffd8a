// Nothing: the target of the precompiled headers wants a source.
