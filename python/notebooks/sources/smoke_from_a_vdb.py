# %% [markdown]
# # Smoke from an OpenVDB file
# A density grid becomes the extinction of a medium: each voxel has the exact mean of the file. The first cell writes a sample; give the path of another file.
# %%
import base64
import zlib
from pathlib import Path

sample = (
    "c-rlq-ESOc6~>>LwH+t6V|yK&eAvyVNs6i@bYpLp{hXP!5CRIq38e@%&F<P>6IbgGd0pd(i;gIjKmxG=35g3NBUK=wf(%?DRoe<G1QJ>V7eV4;"
    ";V)Pacc6xIW@hbm9LH9jRBCvByKm0yJ0I_PpZCnzv5wA0p8doN5bDwnz{i*#J3ktqjK<C-rVH_NvC*-qa}(3C!nv{OiK*g+iHWI1;^TT?C}_*Y"
    "QlFUT7mLN*a&dC3oV$>V<;L`omEf9xdCIrRkNUPl+CFJL(xzuh#oWZi{7P=Nu+r{bZ*pv=TRo9x27}yl<jmZ*NA@+3oSdIsSS*&yGxKvgUU_M8"
    "X70;_vNchfFHc6!L<*BjGt0%ua-sA}vE1K0ZK_x*+$v7xO7n#&9W~eN(T>4juysxa_F(h$+2U+&;?`2JtPal1EyZJ<vaxz`zjxTWbIbE9#ge%A"
    "%G}bX1Dh9blQvhFEpB)oNZl*u3v)Bm^NX{epDdJ$pDir-XEf|bYwKI=CLx;9v%_aX2qA<JLI@#*5JCtcgb+dqA%uJg=?koBjA>4Tmk`hgCI%3~"
    "2g7|H3>$RrafJ7I{&0(9nq1bs-sfuSlOu0OJ-%5eO&>*&_%>adFD&_qZ@J5|<C1>XbG{m+ye*e~d-9fVI|2tEoC0@O+N(i(a0=Xi?%uuID(xdn"
    "fqOP^elvFh`|H3S3ZC!(4L)BAtQFWD^5wqq>Mrx;u9y+;z#;7{=gNg;@w-sY>Eif{qDwU~KVMRZjIC*P&6U*2dkJ;VFBay?rNYwI%sO3qFRlW6"
    "Z$@0resF*D{HE>O#zvjZ<8F-K`a{$7c5N&=A%qY@2qA<JLLNQ*gEk?A5JCtcgb+dq*%Kj3K;92)cW&w%Yd7!c8*4sW`nRK}qf6iD>FUrodVIF@"
    "x5B@M5<&<egb+dqA>>iRzdsN{2qA<JLI@!r0O7!D6&*A954qPD+bNHQc`k%J#%z~=wA=pe@{e}gzf-=`PTViw>7nSd+dQq>`m^<X+dtrceW&&v"
    "miBvTKbLk9t}72+vlCCc=!Mw<qX&cTNf`YI9mPK*mTgC4iF7)fwVXsUld&ut(L~a65KE>qS@|UYSWYySOlGplOc>9}X3B;+2jeCE`p%GvJ~s!W"
    "9q5PA;XU4aP?r-Cmn&o}JDy5^4iyLSMA~*@@f)bvb|#y(ZNx`VwNh!_mK~|I{)BKd+X}wh1hikZ2=k8ED*Qeb=4aAwLraPoSa3xgxaiPHJSW?3"
    "7mR~w@5QPUOZc;oci?L><8)SLGk|N+gzZF+<90?h5xuewOcSB2F!sS%(0|)*K!ncAWux)rmt^di&QGV8$+jb(QNiPf(Lf?C132CovT1p9xAuBd"
    "pxfA(`;=^J)4oH}_it(Ay3=h}uLs<29C8N{>cf+8!?Jx6p~EnSfI*nH9%2mR@1CDJfn-LOstb`=@(^CLbUh_rMzD~P<%_3M=kN<Jl>7kd(}-AA"
    "jnY|}UpkFZ(e&FeUq<^1`rU78>9T$MRV(9|#!=fD7!e7jn&-d~gu2j|{0YXrK>R)yy?{!j4&X#I_FWhw8o_uQ=1D}8mi;IED6PTkh?3U3sAV)>"
    ")iGIx)Lx$yo^VZ3Ga{xo?Nd?zwsDumya)<o0HI!)VhHUL8p9fEp%V!8zzE}Cy<SvlG-NE<k{C(L{U!4H;cx^6jgNG82=7S1c#)^k6UMcq-ZPgl"
    "DhIv*ybSXzFlJRI3A(V`i+vHapHvMYdj1ur_<d8J2YM4`CF*1;QZsPm;;HYzJc4m=o!-P%aUqlaCGclBaS`yRB3{<=g5Ps)uaC*~T7UX0;K#(C"
    "-RO%Vju;Y1$}5G8D=%bWxmnkO4cjZU7?qbCv*)L6yu}Uu9^zBYzJv^&mX{3e>fn|P>v+ZaVsd~wC;Rkkil>Tm<(Z{h>)&$RQtVN$b0a9}`08(c"
    "d+QIr-QBkwe`rcPz8ly#1A8iX;B*9bDd?XH?87ecxV3g;%i6GfBO!zkLI@#*5JGl@3B!aCLI@#*5JCuf<m~)?sN`{k>F(sAJ{VZ;kq|-%A%qY@"
    "2qBLn{QCnTgb+dqA%qa}0dOd=nxvpv3T^9suEm0ng!~_~T?P{iLEfKTXK=l>F6{ZX--xQ(-U^<)KbCe}r2b<gT&*?g4Sf_>5y?CG%4%h;TC1Z9"
    "Cz5wv`EWw3cr8>RyKD6`7<a3Yh%<uvTD2}G$`Pw;wR-JSaH_H=g-T_$8gX2?&{3EL;3yoqs%>B#7A$K&+DsgA4&s9CAcD_04y?1{(*^X~$8aE}"
    "MHkoLSc0u=EAMU-(cWm0;p-xSwl@M9z7@!@R@2!#uDhypZ}j4txWBsAjYhA`$;nH<=p$Q>TM<R7^@b`|MfDlf;R13*MO3IY<Z9vC6Ed&J5SFVo"
    "orcW(DXnLSV_NlZ5C^n^Vp|_R;yi<kGC`*U?L!#%CcEc4kHhPA9#6FW&IGg#2X!91g312CEB1Kr#~(^-gk_CovO1NzhJ?4&uCAsiu&UAwp;C24"
    "s(i(*48V9=Zq)&dM^u;7T0PH9p(-Ka$A-kvaZGxmHZCD57w^IM;3+5DHpXQXC;w@jm;LkNC>mWdkPIq&HGt$Qo*x>U&L_nViI~$GF_zV*GCqMJ"
    "oN@3p4yHuj%MwHuUW8%8d`aVI!0E&#mH0JupT>e0Rkpq7x{vQ+L*x|^SlfHpEb{A{MGii`t|E_!Aacie0&m2Wch~t*<prFmtzmWww?(47r{O`g"
    "kHS1IH&PY($_UJHyd6ZXw^o-C72&_Acc`3wQ6}ulQbqEoaaG21+zdiDWv%j}tlm~(5p%+UirK9<<**aRfqpTg=+y8$tM2c6QA;5jljuB!{U%n?"
    "yf5uNSAZ<FJovARz24FXuNY+2(%%qeTilHV&5@=RAS*%BsZ^z{*?uv;deGJj>sfyDue0Ze^7R&{uZX>}(HA(E51Jb|w-z{9YdYm%y-J`POtLva"
    "|GfVJpQ|nK"
)
path = Path("sample.vdb")
path.write_bytes(zlib.decompress(base64.b85decode(sample)))
print(path.stat().st_size, "bytes")
# %%
import matplotlib.pyplot as plt
import numpy as np
import zonal as zn

low, high, cells = [-5, -5, -5], [150, 75, 45], [16, 8, 5]
scene = zn.Scene("smoke")
scene.surface(rectangle=([-5, -5, -5], [155, 0, 0], [0, 80, 0]), name="ground", reflectance=0.3, patch_size=20)
scene.medium(low, high, cells=cells, extinction=0.0, albedo=0.9)
scene.region(density={"file": str(path), "grid": "density", "scale": 0.05})
scene.sky(1.0)
scene.sun([0.4, 0.3, -1], 5.0)
forecast = scene.check()
print(forecast["voxel_zones"], "voxels")
solution = scene.solve(tolerance=0.05)
print(solution)
# %% [markdown]
# Fluence in the smoke, seen from the side (mean along y) and from above (mean along z):
# %%
fields = solution.medium_arrays()
fluence = (fields["incident"] + fields["direct"]).mean(axis=-1)
fig, axes = plt.subplots(2, 1, figsize=(6, 5), layout="constrained", sharex=True)
for ax, axis, label, extent in ((axes[0], 1, "z / m", (-5, 150, -5, 45)), (axes[1], 2, "y / m", (-5, 150, -5, 75))):
    picture = ax.imshow(fluence.mean(axis=axis).T, origin="lower", extent=extent, cmap="inferno", aspect="equal")
    ax.set(ylabel=label)
axes[1].set(xlabel="x / m")
axes[0].set(title="Fluence rate / (W/m²)")
fig.colorbar(picture, ax=axes)
plt.show()
