"""Pictures of missions: figures from a recording alone, and the Meshcat scene and page (`meshcat_scene`, Drake)."""
