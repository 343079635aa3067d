//! Rendering of a decorated surface (Tong 2002 §6): camera, lights, visibility, shading, frames.
