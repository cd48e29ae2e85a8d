// The leak checker names a library by its place in memory, and follows what its variables point at, so drivers stay
// loaded to the end of the process: what Mesa's keeps for its life (240 bytes) is no leak then, and lsan.supp knows the
// others by name. Linked into tests and the program they start, under AddressSanitizer only.
extern "C" int dlclose(void*) {
  return 0;
}
