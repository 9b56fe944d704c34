"""Several files, or all files of a folder, by one verb."""
