#pragma once
/// Functions of time that carry their first two derivatives along, and the polynomials motions are made of.

#include <array>
#include <cmath>

namespace aslio::simulator {

/// A function of time with its first two derivatives.
struct Jet {
  double x = 0, d = 0, dd = 0;
};
inline Jet operator+(const Jet& a, const Jet& b) { return {a.x + b.x, a.d + b.d, a.dd + b.dd}; }
inline Jet operator*(const Jet& a, const Jet& b) {
  return {a.x * b.x, a.d * b.x + a.x * b.d, a.dd * b.x + 2 * a.d * b.d + a.x * b.dd};
}
inline Jet operator*(double k, const Jet& a) { return {k * a.x, k * a.d, k * a.dd}; }
/// sin(w t + phase)
inline Jet sine(double w, double t, double phase) {
  const double s = std::sin(w * t + phase);
  return {s, w * std::cos(w * t + phase), -w * w * s};
}

/// u^4 (c0 + c1 u + c2 u^2 + c3 u^3)
inline Jet septic(const std::array<double, 4>& c, const Jet& u) {
  Jet sum{c[3], 0, 0};
  for (const double k : {c[2], c[1], c[0]}) sum = sum * u + Jet{k, 0, 0};
  const Jet u2 = u * u;
  return u2 * u2 * sum;
}
/// From 0 to 1, with three vanishing derivatives at both ends.
inline Jet smooth_step(const Jet& u) {
  if (u.x <= 0) return {};
  if (u.x >= 1) return {1, 0, 0};
  return septic({35, -84, 70, -20}, u);
}
/// Rises from 0 to 1 and falls back over [0, 1], with three vanishing derivatives at both ends.
inline Jet bump(const Jet& u) {
  if (u.x <= 0 || u.x >= 1) return {};
  const Jet product = u * (Jet{1, 0, 0} + -1.0 * u), square = product * product;
  return 256.0 * (square * square);
}
/// A function of one variable, given its value and derivatives there, of a function of time.
inline Jet composed(double f, double df, double ddf, const Jet& x) {
  return {f, df * x.d, ddf * x.d * x.d + df * x.dd};
}
inline Jet sine_of(const Jet& x) {
  const double s = std::sin(x.x), c = std::cos(x.x);
  return composed(s, c, -s, x);
}
inline Jet cosine_of(const Jet& x) {
  const double s = std::sin(x.x), c = std::cos(x.x);
  return composed(c, -s, -c, x);
}
/// 0 at both ends, with slope 1 at the second one; the other derivatives up to the third vanish.
inline Jet slope_at_end(const Jet& u) { return septic({-15, 39, -34, 10}, u); }

/// Unit interval [begin, begin + duration] at slowed time.
inline Jet unit_time(const Jet& t, double begin, double duration) {
  return {(t.x - begin) / duration, t.d / duration, t.dd / duration};
}

/// Septic Hermite segment of one coordinate over u in [0, 1].
inline Jet hermite(const Jet& u, double from, double to, double slope_from, double slope_to) {
  return Jet{from, 0, 0} + slope_from * u + (to - from - slope_from) * smooth_step(u) +
         (slope_to - slope_from) * slope_at_end(u);
}

}  // namespace aslio::simulator
