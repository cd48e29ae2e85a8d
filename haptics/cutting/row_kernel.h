// This file is included after cut_kernel.h in namespaces with eight lanes. It reads and writes single rows of a block
// of samples. A row may lie only partly in the box of samples that is cut.

/// A row of a block of samples, with one sample per lane. Only the samples `from` to `to` - 1 are processed.
struct Row {
  float* distance;
  int from, to;
  bool whole;  // true if all samples are processed

  /// Returns the samples of the row. Samples that are not processed get a value so large that no cut raises it.
  TYPODONT_INLINE Floats read() const {
    if (whole) return load(distance);
    Floats old = all(1e9f);
    for (int i = from; i < to; ++i) old[i] = distance[i];
    return old;
  }
  /// Writes the changed samples of the row. `labels`: labels of the samples, used only if the volume is counted.
  TYPODONT_INLINE void write(Floats old, Floats now, const Tissue* labels, Taken& taken) const {
    if (whole) {
      store(distance, now);
    } else {
      for (int i = from; i < to; ++i) distance[i] = now[i];
    }
    const Ints lost = share_taken(old, now);
    if (!taken.removed || !any_of(lost > 0)) return;
    taken.add(lost, labels, distance, from, to);
  }
};
