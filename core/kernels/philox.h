// SPDX-License-Identifier: Apache-2.0
// Philox4x32-10: four random words of a counter of four words and a key of two (Salmon, Moraes, Dror & Shaw,
// SC 2011). Integers only, so all dialects and devices draw the same numbers.

// The upper word of the product of two words, by halves: not all dialects have wider integers.
FN uint mulHigh(uint a, uint b) {
  uint aLow = a & 0xffffu;
  uint aHigh = a >> 16u;
  uint bLow = b & 0xffffu;
  uint bHigh = b >> 16u;
  uint low = aLow * bLow;
  uint middle = aHigh * bLow + (low >> 16u);
  uint other = aLow * bHigh + (middle & 0xffffu);
  return aHigh * bHigh + (middle >> 16u) + (other >> 16u);
}

// Replaces the counter c0..c3 by random words.
FN void philox4x32(uint k0, uint k1, INOUT(uint) c0, INOUT(uint) c1, INOUT(uint) c2, INOUT(uint) c3) {
  uint key0 = k0;
  uint key1 = k1;
  for (UNIFORM int round = 0; round < 10; round++) {
    uint high0 = mulHigh(0xd2511f53u, c0);
    uint low0 = 0xd2511f53u * c0;
    uint high1 = mulHigh(0xcd9e8d57u, c2);
    uint low1 = 0xcd9e8d57u * c2;
    c0 = (high1 ^ c1) ^ key0;
    c1 = low1;
    c2 = (high0 ^ c3) ^ key1;
    c3 = low0;
    key0 += 0x9e3779b9u;
    key1 += 0xbb67ae85u;
  }
}
