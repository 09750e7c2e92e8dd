"""Ensembles: one case over many values, in threads or on a cluster, kept in memory or in a store."""
