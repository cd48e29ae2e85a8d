// Keeps libraries loaded for the leak checker. It follows pointers in the variables of loaded libraries, and names
// leaks by library. So the 240 bytes that Mesa's driver keeps are not reported, and lsan.supp can name the others.
// Linked into tests and the programs that they start, only with AddressSanitizer.
extern "C" int dlclose(void*) {
  return 0;
}
