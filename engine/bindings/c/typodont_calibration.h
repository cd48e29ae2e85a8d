/* Calibration from numbers: registration of points, the delay between two recordings. Rules of results and threads:
 * typodont.h. */
#ifndef TYPODONT_CALIBRATION_H
#define TYPODONT_CALIBRATION_H

#include "typodont.h"

#ifdef __cplusplus
extern "C" {
#endif

/* The rigid motion between the haptic base H and the display D: p_D = X_DH * p_H. */
typedef struct typodont_registration {
  uint32_t struct_size;
  uint32_t trusted; /* 0: the points leave something open; typodont_error() says what */
  typodont_pose X_DH;
  double fre_rms;        /* m, over the inliers */
  double sigma;          /* m per axis; NaN when nothing determines it */
  double covariance[36]; /* of (rotation vector in rad, translation in m) in D, row-major */
  double predicted_tre;  /* m rms, over the box of the inliers */
  uint64_t outliers;
} typodont_registration;

/* `count` pairs, 3 numbers a point, m. `inlier` (may be NULL): count bytes, 1 where the pair was used. `known_sigma`
 * 0: estimated from the residuals. */
TYPODONT_API typodont_result typodont_register(const double* p_H, const double* p_D, size_t count, double known_sigma,
                                               typodont_registration* out, uint8_t* inlier);

typedef struct typodont_delay {
  uint32_t struct_size;
  uint32_t ambiguous;
  double delay; /* s; positive: B lags A */
  double sigma; /* s */
} typodont_delay;

/* Two recordings of one motion: times in s, rising, and 3 numbers a point, m. */
TYPODONT_API typodont_result typodont_estimate_delay(const double* t_a, const double* p_a, size_t count_a,
                                                     const double* t_b, const double* p_b, size_t count_b,
                                                     double max_delay, typodont_delay* out);

#ifdef __cplusplus
}
#endif
#endif
