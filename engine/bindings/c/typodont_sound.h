/* The drill's sound: autoregressive models of recordings, and the synthesizer that uses them. typodont.h explains
 * handles, results and threads. */
#ifndef TYPODONT_SOUND_H
#define TYPODONT_SOUND_H

#include "typodont.h"

#ifdef __cplusplus
extern "C" {
#endif

typedef struct typodont_synth typodont_synth;

/* The input of the synthesizer from one tick. */
typedef struct typodont_sound_state {
  uint32_t struct_size;
  uint32_t tissue;
  int64_t t_ns;        /* ns, time of the state; it applies from the nearest audio sample on */
  double spindle;      /* rad/s, rotation speed of the spindle */
  double pedal;        /* position of the pedal, 0 (released) to 1 */
  double contact_area; /* m2, area of the head in contact with tissue */
  double force;        /* N */
  double removal_rate; /* m3/s, volume of tissue removed per second */
  double slip_speed;   /* m/s, speed of a hand instrument along the surface */
  double suction;      /* 0..1 */
  uint32_t turns;      /* 1: a rotating instrument; 0: a hand instrument, which scrapes and taps */
  uint32_t reserved;
} typodont_sound_state;

/* Creates a synthesizer from a voice file or a model file (.json), or from a shipped voice by its name ("micromotor").
 * The same voice, rate, seed and states give the same samples. */
TYPODONT_API typodont_result typodont_synth_new(const char* voice, double sample_rate, uint64_t seed,
                                                typodont_synth** out);
TYPODONT_API typodont_result typodont_synth_free(typodont_synth* synth);
/* Adds a state. The states must be in the order of time. */
TYPODONT_REALTIME TYPODONT_API typodont_result typodont_synth_push(typodont_synth* synth,
                                                                   const typodont_sound_state* state);
/* Computes the next `count` samples of one channel, with full scale 1. The very first sample is at time 0. */
TYPODONT_REALTIME TYPODONT_API typodont_result typodont_synth_render(typodont_synth* synth, float* samples,
                                                                     size_t count);

/* Fits an autoregressive model to a recording (any sound file) and writes it (.json). `order` is "300", "aic" or "bic";
 * NULL means "300". `distance_dB` (may be NULL) receives the log-spectral distance of the model to the recording. */
TYPODONT_API typodont_result typodont_sound_fit(const char* recording, const char* order, const char* model,
                                                double* distance_dB);

#ifdef __cplusplus
}
#endif
#endif
