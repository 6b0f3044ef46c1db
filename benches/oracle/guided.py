"""Importance sampling for Mitsuba: a phase function and a matt surface that also look towards the lamps.

In sea water nearly all light that turns back and reaches the camera took one rare turn (2 % of the scattering is backwards) and
then went on within a few degrees of the line from a lamp. Sampling by the phase function alone finds such paths once in 10^4 and
gives each of them an enormous weight. Here a share GUIDED of the directions is drawn around the directions to the lamps, and the
weight p/q makes up for it: the mean is the same, the variance is not (`run.py checks` compares both).
"""

import json

import drjit as dr
import mitsuba as mi

PETZOLD3 = [(0.42567, 0.98842), (0.57153, 0.88076), (0.00280, -0.55225)]  # weight, g
GUIDES = [(0.5, 0.985), (0.5, 0.9)]
GUIDED = 0.35


def lobe_value(g, one_minus_cos):
    x = (1 - g) ** 2 + 2 * g * one_minus_cos
    return (1 - g * g) * dr.inv_four_pi / (x * dr.sqrt(x))


def mixture_value(lobes, axis, wo):
    """The sum of Henyey-Greenstein lobes around an axis, sr^-1; 1 - cos without cancellation."""
    d = wo - axis
    one_minus_cos = 0.5 * dr.dot(d, d)
    return sum(w * lobe_value(g, one_minus_cos) for w, g in lobes)


def lobe_sample(g, axis, sample):
    s = (1 - g * g) / (1 - g + 2 * g * sample.x)
    cos = (1 + g * g - s * s) / (2 * g)
    sin = dr.safe_sqrt(1 - cos * cos)
    sin_phi, cos_phi = dr.sincos(dr.two_pi * sample.y)
    return mi.Frame3f(axis).to_world(mi.Vector3f(sin * cos_phi, sin * sin_phi, cos))


def choose(sample, items):
    """The item whose interval of cumulated weights holds the sample, and where in it."""
    low, chosen = 0.0, None
    for weight, make in items:
        value = make()
        chosen = value if chosen is None else dr.select(sample >= low, value, chosen)
        low += weight
    return chosen


class Guide:
    """Directions around those from a point to the lamps."""

    def __init__(self, props):
        self.lamps_m = json.loads(props["lamps_m"])

    def axes(self, p):
        return [dr.normalize(mi.Point3f(*lamp) - p) for lamp in self.lamps_m]

    def pdf(self, p, wo):
        axes = self.axes(p)
        return sum(mixture_value(GUIDES, axis, wo) for axis in axes) / len(axes)

    def items(self, p, share, sample2):
        share = share / len(self.lamps_m)
        return [(share * w, lambda a=axis, g=g: lobe_sample(g, a, sample2)) for axis in self.axes(p) for w, g in GUIDES]


class GuidedPhase(mi.PhaseFunction):
    def __init__(self, props):
        mi.PhaseFunction.__init__(self, props)
        self.lobes = json.loads(props["lobes"])
        self.guide = Guide(props)
        self.m_flags = mi.PhaseFunctionFlags.Anisotropic

    def values(self, mei, wo):
        p = mixture_value(self.lobes, -mei.wi, wo)
        return p, (1 - GUIDED) * p + GUIDED * self.guide.pdf(mei.p, wo)

    def eval_pdf(self, ctx, mei, wo, active=True):
        p, q = self.values(mei, wo)
        return mi.Color3f(p), q

    def sample(self, ctx, mei, sample1, sample2, active=True):
        items = [((1 - GUIDED) * w, lambda g=g: lobe_sample(g, -mei.wi, sample2)) for w, g in self.lobes] + self.guide.items(
            mei.p, GUIDED, sample2
        )
        wo = choose(sample1, items)
        p, q = self.values(mei, wo)
        return wo, mi.Color3f(p / q), q


class GuidedMatt(mi.BSDF):
    """Lambert's surface, one-sided."""

    def __init__(self, props):
        mi.BSDF.__init__(self, props)
        self.guide = Guide(props)
        self.albedo = json.loads(props["albedo"])
        flags = mi.BSDFFlags.DiffuseReflection | mi.BSDFFlags.FrontSide
        self.m_components = [flags]
        self.m_flags = flags

    def sample(self, ctx, si, sample1, sample2, active):
        cosine = lambda: si.to_world(mi.warp.square_to_cosine_hemisphere(sample2))
        items = [(1 - GUIDED, cosine)] + self.guide.items(si.p, GUIDED, sample2)
        wo = si.to_local(choose(sample1, items))
        bs = mi.BSDFSample3f()
        bs.wo = wo
        bs.pdf = self.pdf(ctx, si, wo, active)
        bs.eta = 1.0
        bs.sampled_type = mi.UInt32(+mi.BSDFFlags.DiffuseReflection)
        bs.sampled_component = mi.UInt32(0)
        value = self.eval(ctx, si, wo, active)
        return bs, dr.select(bs.pdf > 0, value / bs.pdf, 0)

    def eval(self, ctx, si, wo, active):
        lit = active & (si.wi.z > 0) & (wo.z > 0)
        return mi.Color3f(self.albedo) * dr.select(lit, wo.z * dr.inv_pi, 0)

    def pdf(self, ctx, si, wo, active):
        cosine = dr.select(wo.z > 0, wo.z * dr.inv_pi, 0)
        q = (1 - GUIDED) * cosine + GUIDED * self.guide.pdf(si.p, si.to_world(wo))
        return dr.select(active & (si.wi.z > 0), q, 0)

    def eval_pdf(self, ctx, si, wo, active):
        return self.eval(ctx, si, wo, active), self.pdf(ctx, si, wo, active)


def register():
    mi.register_phase("guided", GuidedPhase)
    mi.register_bsdf("guided_matt", GuidedMatt)
