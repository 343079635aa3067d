//! Texton analysis (Tong 2002 §4): filter bank, representative images, vocabulary, Gram matrix.
