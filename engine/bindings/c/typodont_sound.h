/* The drill's sound: autoregressive models of recordings, and the synthesizer that speaks with them. Rules of handles,
 * results and threads: typodont.h. */
#ifndef TYPODONT_SOUND_H
#define TYPODONT_SOUND_H

#include "typodont.h"

#ifdef __cplusplus
extern "C" {
#endif

typedef struct typodont_synth typodont_synth;

/* What the ear needs of one tick. */
typedef struct typodont_sound_state {
  uint32_t struct_size;
  uint32_t tissue;
  int64_t t_ns;        /* takes effect at the sample nearest to it */
  double spindle;      /* rad/s */
  double pedal;        /* 0..1 */
  double contact_area; /* m2 */
  double force;        /* N */
  double removal_rate; /* m3/s */
  double slip_speed;   /* m/s along the surface, of hand instruments */
  double suction;      /* 0..1 */
  uint32_t turns;      /* 0: a hand instrument, which scrapes and taps */
  uint32_t reserved;
} typodont_sound_state;

/* A voice or model file (.json), or the name of a shipped one ("micromotor"). The same voice, rate, seed and states
 * give the same samples. */
TYPODONT_API typodont_result typodont_synth_new(const char* voice, double sample_rate, uint64_t seed,
                                                typodont_synth** out);
TYPODONT_API typodont_result typodont_synth_free(typodont_synth* synth);
/* In the order of time. */
TYPODONT_REALTIME TYPODONT_API typodont_result typodont_synth_push(typodont_synth* synth,
                                                                   const typodont_sound_state* state);
/* The next `count` samples, one channel, full scale 1. The first of all is at time 0. */
TYPODONT_REALTIME TYPODONT_API typodont_result typodont_synth_render(typodont_synth* synth, float* samples,
                                                                     size_t count);

/* Fits an autoregressive model to a recording (any sound file) and writes it (.json). `order` "300", "aic" or "bic";
 * NULL: "300". `distance_dB` (may be NULL): log-spectral distance of the model to the recording. */
TYPODONT_API typodont_result typodont_sound_fit(const char* recording, const char* order, const char* model,
                                                double* distance_dB);

#ifdef __cplusplus
}
#endif
#endif
