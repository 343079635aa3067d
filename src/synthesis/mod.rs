//! Synthesis of the surface texton map (Tong 2002 §5): order, candidates, metric, passes.
