/* Calibration from arrays of numbers: registration of points, and the delay between two recordings. typodont.h explains
 * results and threads. */
#ifndef TYPODONT_CALIBRATION_H
#define TYPODONT_CALIBRATION_H

#include "typodont.h"

#ifdef __cplusplus
extern "C" {
#endif

/* The rigid motion between the haptic base H and the display D: p_D = X_DH * p_H. */
typedef struct typodont_registration {
  uint32_t struct_size;
  uint32_t trusted; /* 0: the points do not determine the whole pose; typodont_error() names the reason */
  typodont_pose X_DH;
  double fre_rms;        /* m, fiducial error of the inliers */
  double sigma;          /* m, standard deviation of the points per axis; NaN if the pairs do not determine it */
  double covariance[36]; /* 6 x 6, of (rotation vector in rad, translation in m) in D, row-major */
  double predicted_tre;  /* m rms, expected target error in the box around the inliers */
  uint64_t outliers;
} typodont_registration;

/* Fits the motion to `count` pairs of points (3 numbers per point, m). `inlier` (may be NULL) receives `count` bytes,
 * with 1 for each pair that was used. With `known_sigma` 0 the noise is estimated from the residuals. */
TYPODONT_API typodont_result typodont_register(const double* p_H, const double* p_D, size_t count, double known_sigma,
                                               typodont_registration* out, uint8_t* inlier);

typedef struct typodont_delay {
  uint32_t struct_size;
  uint32_t ambiguous;
  double delay; /* s; positive: recording B is later than A */
  double sigma; /* s, standard deviation of the delay */
} typodont_delay;

/* Estimates the delay between two recordings of one motion: increasing times in s, and 3 numbers per point in m.
 * `max_delay` (s) limits the search. */
TYPODONT_API typodont_result typodont_estimate_delay(const double* t_a, const double* p_a, size_t count_a,
                                                     const double* t_b, const double* p_b, size_t count_b,
                                                     double max_delay, typodont_delay* out);

#ifdef __cplusplus
}
#endif
#endif
