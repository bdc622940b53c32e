// Round bar, as a STEP file. Made for kinetostat, to show that the error bar holds for the round section, not for facets.
// Regenerate cylinder.step: scripts/make-meshes. Units mm. The bar runs along x from the origin.
SetFactory("OpenCASCADE");

diameter = 40; length = 200;
Cylinder(1) = {0, 0, 0, length, 0, 0, diameter / 2};
