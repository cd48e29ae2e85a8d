// The leak checker names a library by its place in memory, so drivers stay loaded to the end of the process: lsan.supp
// knows them by name. Linked into tests under AddressSanitizer only.
extern "C" int dlclose(void*) { return 0; }
