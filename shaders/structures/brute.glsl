// Finds the closest triangle that `ray` hits by trying every one: the ground truth of the other walks.
//
// Requires  triangles[] in any order; `at.x` the first triangle to try.
// Ensures   as every walk (shaders/trace.glsl); at.x == triangleCount when done.
// Cost      O(triangles).
void walk(WalkRay ray, INOUT(uvec4) at, uint maxSteps, INOUT(Hit) best) {
    uint end = header.triangleCount;
    for (uint step = 0u; at.x < end && step < maxSteps; ++step) {
        bool hit = testTriangle(ray, at.x, best);
        at.x = ANY_HIT && hit ? end : at.x + 1u;
    }
}

// One a triangle.
float mostSteps() { return float(int(header.triangleCount)) + 1.0f; }

bool isDone(uvec4 at) { return at.x >= header.triangleCount; }
