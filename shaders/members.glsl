// Names every member of every struct that crosses the border, in order, so that a test can see whether the device finds in
// each what the host has put there.
//
// Whoever includes this declares put() for float, uint, vec3, vec4 before it.

void putAll(Ray s) { put(s.origin); put(s.tMin); put(s.direction); put(s.tMax); }

void putAll(Hit s) { put(s.t); put(s.u); put(s.v); put(s.primitive); }

void putAll(StructureHeader s) {
    put(s.lo); put(s.nodeCount); put(s.hi); put(s.triangleCount);
    put(s.gridOrigin); put(s.walk); put(s.gridStep); put(s.unit);
}

void putAll(FrameParams s) {
    put(s.eye); put(s.halfWidth); put(s.forward); put(s.halfHeight); put(s.right); put(s.orthographic);
    put(s.up); put(s.minContribution); put(s.zenith); put(s.width); put(s.horizon); put(s.height);
    put(s.ground); put(s.samples); put(s.ambient); put(s.seed); put(s.maxDepth); put(s.slots);
    put(s.lightCount); put(s.emitterCount); put(s.shadowRays); put(s.materialsAt); put(s.lightsAt); put(s.emittersAt);
    put(s.trianglesAt); put(s.verticesAt); put(s.vertexStride); put(s.texturesAt); put(s.decodeAt);
    put(s.spheresAt); put(s.instancesAt); put(s.instanceCount);
    put(s.left); put(s.top); put(s.partWidth); put(s.partHeight);
    put(s.lensRadius); put(s.lensSlope); put(s.mediaAt); put(s.eyeMedia);
    put(s.environmentAt); put(s.environmentSide); put(s.reach); put(s.roulette);
    put(s.emitterScale); put(s.unused0); put(s.unused1); put(s.unused2);
}

void putAll(ItemView s) { put(s.x); put(s.y); put(s.z); put(s.w); put(s.eye); put(s.instancesAt); }

void putAll(ItemCall s) { put(s.first); put(s.referencesAt); put(s.listAt); put(s.unused); }

void putAll(ItemWindow s) { put(s.firstRow); put(s.rows); put(s.scale); put(s.unused); }

void putAll(TileStep s) { put(s.count); put(s.listAt); put(s.nextAt); put(s.compacts); put(s.firstPixel); }

void putAll(PathState s) {
    put(s.weight); put(s.depth); put(s.sum); put(s.discarded); put(s.pixel); put(s.sampleIndex); put(s.key);
    put(s.pendingCount); put(s.shadowRays); put(s.deepest); put(s.media); put(s.forgotten); put(s.travelled);
    put(s.passes); put(s.density); put(s.unused);
}

void putAll(PendingRay s) {
    put(s.origin); put(s.depth); put(s.direction); put(s.key); put(s.weight); put(s.media);
    put(s.travelled); put(s.passes); put(s.begin); put(s.density);
}

void putAll(PixelResult s) {
    put(s.sum); put(s.discarded); put(s.pixel); put(s.shadowRays); put(s.deepest); put(s.forgotten);
}

void putAll(PrimaryHit s) {
    put(s.position); put(s.depth); put(s.normal); put(s.u); put(s.albedo); put(s.v);
    put(s.primitive); put(s.instance); put(s.material); put(s.pixel);
}
