"""One scenario of an FMU in every importer that is installed here: ``python -m fmu_orchestrator.importers MODEL.fmu``."""
