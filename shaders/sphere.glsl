// One ray against one sphere, in single precision: intersectTriangle's sibling (intersect.glsl).

// Tests the sphere of that radius about `centre`, which is hit from outside and from inside. True if it became the best hit:
// the nearer of the two points in [tMin, best.t] counts, equal distances go to the lowest id; u = v = 0.
//
// Requires  0 < radius; all of the sphere within the bounds that the ray was prepared with.
// Ensures   the point at t lies within 53 u M of the sphere's surface, as that of a triangle does (SLACK is 64 u M). Which
//           side of the sphere the ray starts on is decided once, by the sign of `power`: from inside every ray meets it, at
//           one distance that is not negative; from outside both distances have the same sign.
// Cost      three divisions and a square root. Lengths are scaled by a power of two, so that no square leaves the range of
//           floats, whatever the radius and however far the ray starts.
//
// Why 53 u M. f, from the centre to the origin, has |f| <= 1.8 M, and r <= M. Rounded, b is off by 4 u |f| |d|, a by 3 u, so
// the nearest point on the line by 7 u |f| along the line, and across it `off` by 6 u |f|: the line passes the centre as far
// off as computed, to 6 u |f| (rounding along the line counts only by its square). What `rest` adds is 3 u r^2.
//   - The farther of the distances, q / a, is a sum of like signs: in the plane of line and centre its point is misplaced by
//     8 u |f| along and 6 u |f| across, and r by 3 u: 10 u |f| + 3 u r in all.
//   - The nearer one is power / q. With g(t) = |f + t d|^2 - r^2, which is 0 on the surface, an error e of power moves g at
//     that t by e 2 root / q, and one of q by at most 2 r times what it misplaces the farther point by: as the product of
//     both distances is given, g is an error of power less one of the farther distance. e is 6 u f^2 + 2 u r^2; where |f| <=
//     2 r, root <= q makes that 12 u |f| + 2 u r of the place, and where |f| > 2 r, root <= r |d| and q >= 0.86 |f| |d| make
//     it 7 u |f|. So 25 u |f| + 5 u r with the rest, or 50 u M.
//   - q^2 >= a |power|, but for rounding: where it is not, the ray starts on the surface and along it, both distances are
//     below sqrt(6 u) r, and so far along a tangent the sphere is 3 u r away.
// As (|f| - r) (|f| + r), power would be a fifth farther off on average, and cost a root.
// Measured against 113-bit arithmetic: 7 u M at most, and so are misses and phantoms 3 u M from tangency at most.
// Source    Haines, Günther, Akenine-Möller 2019, "Precision Improvements for Ray/Sphere Intersection", in Ray Tracing Gems:
//           the discriminant from the distance of centre and line [Hearn, Baker 2004, "Computer Graphics with OpenGL"], and
//           no difference of b and the root.
bool intersectSphere(WalkRay ray, vec3 centre, float radius, uint id, bool obstacle, INOUT(Hit) best) {
    precise vec3 away = ray.origin - centre;
    vec3 extent = vec3(abs(away.x), abs(away.y), abs(away.z));
    float largest = extent.x > extent.y ? extent.x : extent.y;
    largest = extent.z > largest ? extent.z : largest;
    largest = radius > largest ? radius : largest;
    uint exponent = max(floatBitsToUint(largest) & 0x7f800000u, 0x00800000u);
    float size = uintBitsToFloat(exponent);
    float scale = inverseOfPower(size);
    precise vec3 f = away * scale;
    precise float r = radius * scale;
    vec3 d = ray.direction;

    precise float a = d.x * d.x + d.y * d.y + d.z * d.z;
    precise float b = -(f.x * d.x + f.y * d.y + f.z * d.z);
    precise float nearest = b / a;
    precise vec3 off = f + nearest * d;
    precise float square = r * r;
    precise float rest = square - (off.x * off.x + off.y * off.y + off.z * off.z);
    precise float power = (f.x * f.x + f.y * f.y + f.z * f.z) - square;
    bool meets = rest >= 0.0f || power <= 0.0f;
    precise float root = sqrt(a * pick(rest > 0.0f, rest, 0.0f));
    precise float sum = b + root;
    precise float difference = b - root;
    float q = pick(b < 0.0f, difference, sum);
    precise float one = q / a;
    precise float other = power / pick(q == 0.0f, 1.0f, q);
    precise float squared = q * q;
    precise float least = a * abs(power);
    precise float opposite = -one;
    float tangent = pick(power < 0.0f, opposite, one);
    other = pick(squared < least, tangent, other);
    precise float first = pick(one < other, one, other) * size;
    precise float second = pick(one < other, other, one) * size;

    float t = pick(first >= ray.tMin, first, second);
    bool nearer = t < best.t || (t == best.t && id < best.primitive);
    bool better = meets && obstacle && t >= ray.tMin && nearer;
    best.t = better ? t : best.t;
    best.u = better ? 0.0f : best.u;
    best.v = better ? 0.0f : best.v;
    best.primitive = better ? id : best.primitive;
    return better;
}
