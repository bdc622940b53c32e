// A round post on a square plate, two solids that touch. Made for kinetostat, to show assemblies.
// Regenerate post_on_plate.step: scripts/make-meshes. Units mm. Solid 1 is the plate, 2 the post.
SetFactory("OpenCASCADE");

Box(1) = {-40, -40, 0, 80, 80, 12};
Cylinder(2) = {0, 0, 12, 0, 0, 100, 15};
