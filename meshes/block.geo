// Solid block. Made for kinetostat, to validate error bars.
// Regenerate block.stl: scripts/make-meshes. Units mm. The block stands on x = 0.
SetFactory("OpenCASCADE");

Box(1) = {0, -25, -20, 60, 50, 40};

Mesh.MeshSizeMin = 100;
