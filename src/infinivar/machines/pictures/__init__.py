"""Pictures of machines at one steady point, in strokes that figures and pages paint alike."""
