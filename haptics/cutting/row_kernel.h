// Rows of samples that may lie partly outside the processed region. Eight SIMD lanes; included after cut_kernel.h.

/// A row with one sample per lane; only the lanes `from` to `to` - 1 are processed.
struct Row {
  float* distance;
  int from, to;
  bool whole;  // true if all samples are processed

  /// Reads the row's samples. Lanes that are not processed get 1e9, a distance that no cut can increase.
  TYPODONT_INLINE Floats read() const {
    if (whole) return load(distance);
    Floats old = all(1e9f);
    for (int i = from; i < to; ++i) old[i] = distance[i];
    return old;
  }
  /// Writes the samples. `labels`: needed only if the removed volume is counted.
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
