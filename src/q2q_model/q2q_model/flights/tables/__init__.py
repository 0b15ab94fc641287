"""Import of flights from foreign tables: CSV and Parquet, logs of SD cards; their columns and vehicles."""
