// A source for the target of the precompiled headers: CMake needs one.
