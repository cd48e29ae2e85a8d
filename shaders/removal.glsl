// Pass 3 of sphere packings (paper S2 in docs/papers.md, eq. 6): computes the part of a sphere that remains after a
// ball's cut. Same computation as SphereTissue::after_cut() and SphereTissue::left_of().

// Returns the volume (m³) that a cut leaves of a sphere, with its part of the gaps between the spheres.
double left_of(Sphere s, double curve) {
  double r = radius_of(s);
  precise double least = kMin * s.base_radius;
  if (!(r > least)) return 0.0LF;
  double base = ball_volume(s.whole_radius);
  if (pass.printed != 0u) {
    precise double left = s.whole_volume * ball_volume(r) / base;
    return left;
  }
  precise double deep = 2.0LF * (s.whole_radius - s.base_radius) + s.overlap;
  precise double apart = curve + s.whole_radius - deep;
  precise double left = s.whole_volume * (1.0LF - lens_volume(curve, s.whole_radius, apart) / base);
  return left;
}

// A ball of radius r moves from a to b. Returns its largest overlap with a sphere on this path. `away`: direction away
// from the path.
double overlap_of(dvec3 a, dvec3 b, double r, dvec3 center, double radius, out dvec3 away) {
  dvec3 off = minus(center, nearest_on(a, b, center));
  precise double distance = sqrt(dot3(off, off));
  precise dvec3 direction = off / distance;
  away = distance > 0.0LF ? direction : dvec3(0.0LF, 0.0LF, 1.0LF);
  precise double overlap = r + radius - distance;
  return overlap;
}

// Returns true if the ball comes near the sphere on the line from a to n (Ball). The CPU's search tree uses the same
// test.
bool is_near(Sphere s, Ball ball) {
  double r = tree_radius(s);
  if (!(r > 0.0LF)) return false;
  precise double reach = r + ball.r;
  dvec3 center = center_of(s);
  dvec3 off =
      minus(center, nearest_on(dvec3(ball.ax, ball.ay, ball.az), dvec3(ball.nx, ball.ny, ball.nz), center));
  precise double reach2 = reach * reach;
  return dot3(off, off) < reach2;
}

// Replaces `s` by its part that remains after the ball's cut. Returns false if nothing remains.
bool after_cut(inout Sphere s, Ball ball) {
  dvec3 a = dvec3(ball.ax, ball.ay, ball.az), b = dvec3(ball.bx, ball.by, ball.bz), away;
  double overlap = overlap_of(a, b, ball.r, dvec3(s.bx, s.by, s.bz), s.base_radius, away);
  if (s.overlap > 0.0LF &&
      (dot3(away, dvec3(s.ax, s.ay, s.az)) < kSameSide || ball.r != s.tool || !(overlap > s.overlap))) {
    dvec3 center = center_of(s);
    s = Sphere(center.x, center.y, center.z, radius_of(s), s.volume, 0.0LF, 0.0LF, 0.0LF, 0.0LF, 0.0LF,
               s.whole_radius, s.whole_volume);
    overlap = overlap_of(a, b, ball.r, center, s.base_radius, away);
  }
  if (!(overlap > kTouching)) return false;
  precise double all = 2.0LF * s.base_radius;
  s.overlap = all < overlap ? all : overlap;
  s.ax = away.x;
  s.ay = away.y;
  s.az = away.z;
  s.tool = ball.r;
  double left = left_of(s, ball.curve);
  s.volume = left < s.volume ? left : s.volume;
  return true;
}
