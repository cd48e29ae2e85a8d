/* same_bits SCENE HAND RATE SESSION RECORDED: the hand, run through the C interface, feels what the program recorded in
 * SESSION, bit for bit; it is recorded into RECORDED. */
#include <stdio.h>
#include <stdlib.h>
#include <string.h>
#include <typodont.h>

static void must(typodont_result result, const char* what) {
  if (result == TYPODONT_OK) return;
  fprintf(stderr, "%s: %s\n", what, typodont_error());
  exit(1);
}

int main(int count, char** words) {
  if (count != 6) return 2;
  typodont_scene* scene;
  typodont_hand* hand;
  typodont_core* core;
  typodont_session* session;
  must(typodont_scene_open(words[1], NULL, &scene), "scene");
  must(typodont_hand_open(scene, words[2], atof(words[3]), &hand), "hand");
  must(typodont_core_new(scene, hand, NULL, &core), "core");
  must(typodont_core_record(core, words[5], "c"), "record");
  must(typodont_session_open(words[4], &session), "session");
  typodont_session_info info = {.struct_size = sizeof info};
  must(typodont_session_info_of(session, &info), "info");
  typodont_tick* expected = calloc(info.ticks, sizeof *expected);
  expected->struct_size = sizeof *expected;
  size_t read = 0, done = 0;
  must(typodont_session_ticks(session, 0, expected, info.ticks, &read), "ticks");
  for (size_t i = 0; i < read; ++i) {
    typodont_sample sample = {.struct_size = sizeof sample};
    typodont_tick tick = {.struct_size = sizeof tick};
    must(typodont_hand_read(hand, &sample), "hand's sample");
    must(typodont_core_tick(core, &sample, &tick, NULL), "tick");
    must(typodont_hand_write(hand, tick.force, tick.torque), "force");
    if (memcmp(tick.force, expected[i].force, sizeof tick.force) || tick.cuts != expected[i].cuts ||
        memcmp(tick.X_WG.q, expected[i].X_WG.q, sizeof tick.X_WG.q) || tick.faults != expected[i].faults ||
        memcmp(&tick.X_WT, &expected[i].X_WT, sizeof tick.X_WT) || tick.cutting_power != expected[i].cutting_power) {
      fprintf(stderr, "tick %zu differs\n", i);
      return 1;
    }
    ++done;
  }
  typodont_sample more = {.struct_size = sizeof more};
  if (typodont_hand_read(hand, &more) != TYPODONT_END) return fprintf(stderr, "the hand goes on\n"), 1;
  unsigned long long hash = 0;
  uint64_t field = 0;
  must(typodont_core_hash(core, &field), "hash");
  must(typodont_core_finish(core), "finish");
  hash = field;
  printf("%zu ticks, %llu cuts, field %016llx\n", done, (unsigned long long)expected[read - 1].cuts, hash);
  free(expected);
  must(typodont_session_free(session), "free");
  must(typodont_core_free(core), "free");
  must(typodont_hand_free(hand), "free");
  must(typodont_scene_free(scene), "free");
  return 0;
}
