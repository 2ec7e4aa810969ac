# SPDX-License-Identifier: Apache-2.0
"""Figure 11: how old light shows while the sun moves by 0.5 degrees a second: largest luminance difference about 1.5%.

The paper: two clouds at two times of day, at the frame rate of its machine, which Figure 1 gives as 50 per second: 0.01 degrees a frame, m = 100. Here
the clouds of make_clouds.py, sun high and low, frame 400 of the sequence against the same frame of a scene in which the sun has always stood there.
One frame has photon noise, which the paper names as most of its difference: `noise` is the same difference of two frames with other photons; both with 16
frames averaged. Claimed: the trend."""
import make_clouds

FRAME, RATE, M = 400, 0.01, 100
PAPER = 0.015


def run(lab):
    rows = []
    for cloud in ('congestus', 'altostratus'):
        for label, elevation in (('day', 45.0), ('evening', 12.0)):
            end = elevation - RATE * FRAME
            moving, knobs = make_clouds.make(lab, cloud, (240, 150), f'elevation: {{frames: [0, {FRAME}], values: [{elevation}, {end}]}}, azimuth: 230')
            still, _ = make_clouds.make(lab, cloud, (240, 150), f'elevation: {end}, azimuth: 230')
            knobs |= {'tpm.generations': M, 'tpm.photons': 819200}
            words = ('--spp', 16, '--frame', FRAME)
            lab.render(moving, 'figure11_moving', knobs, words=words)
            lab.render(still, 'figure11_still', knobs, words=words)
            lab.render(still, 'figure11_other', knobs, words=(*words, '--seed', 5))
            old = lab.compare('figure11_moving', lab.work / 'figure11_still.exr')
            noise = lab.compare('figure11_other', lab.work / 'figure11_still.exr')
            rows.append({'cloud': cloud, 'time': label, 'largest': old['largest'], 'bias': old['relative_bias'], 'rmse': old['relative_rmse'],
                         'noise_largest': noise['largest'], 'noise_rmse': noise['relative_rmse'], 'paper_largest': PAPER})
    lab.write(rows)
